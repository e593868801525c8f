"""What `satdyn check` proves, and that it reports errors."""

from satdyn_ros.bag import write_run
from satdyn_ros.cli import check
from satdyn_ros.exact.recognise import CANDIDATES


def test_every_closed_form_is_flown():
    """Each motion that can be recognised is among the flights, and agrees."""
    found = list(check.differences())
    assert [difference.flight for difference in found] == list(check.FLIGHTS)
    assert {difference.motion for difference in found} == {motion.name for motion in CANDIDATES}
    assert all(difference.is_allowed for difference in found)


def test_a_good_install_passes(capsys):
    """The answer is yes, with a line for each flight and one for the bag."""
    assert check.check()
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.endswith('(allowed 1e-09)') for line in lines) == len(check.FLIGHTS)
    assert lines[-1] == 'all is well'


def test_a_motion_that_is_off_is_reported(monkeypatch, capsys):
    """An error of 1e-8 rad in a closed form makes the answer no."""
    recognise = check.recognise

    def slower(system, state):
        motion = recognise(system, state)
        assert motion is not None
        at = motion.at
        monkeypatch.setattr(motion, 'at', lambda t_s: at(t_s * (1.0 - 1e-9)))
        return motion

    monkeypatch.setattr(check, 'recognise', slower)
    assert not check.check()
    assert 'NOT GOOD' in capsys.readouterr().out


def test_a_bag_that_is_off_is_reported(monkeypatch, capsys):
    """A sample that was recorded wrong makes the answer no."""
    right = write_run.Recording.ticks

    def wrong(self, stamps_ns, table, measured, snapshot):
        attitude, *_ = table.fields
        table.messages(attitude)['quaternion'][0, 0] += 1e-6
        return right(self, stamps_ns, table, measured, snapshot)

    monkeypatch.setattr(write_run.Recording, 'ticks', wrong)
    assert not check.check()
    assert 'NOT GOOD' in capsys.readouterr().out
