"""What is reported where Fast DDS finds a node and cannot reach it."""

import os

import pytest
import rclpy

from satdyn_ros.ros.other_users import unreached


@pytest.fixture
def shared(tmp_path, monkeypatch):
    """Return a directory in the place of /dev/shm, with the file of a participant of ours."""
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS', raising=False)
    monkeypatch.setattr(rclpy, 'get_rmw_implementation_identifier', lambda: 'rmw_fastrtps_cpp')
    (tmp_path / 'fastrtps_e0ca4075b2ea041c').touch()
    return tmp_path


def test_another_user_is_named(shared, monkeypatch):
    """The owner of a file of Fast DDS that is not ours, and what helps."""
    assert unreached(shared) == ''
    monkeypatch.setattr(os, 'geteuid', lambda: 54321)
    sentence = unreached(shared)
    assert 'FASTDDS_BUILTIN_TRANSPORTS=UDPv4' in sentence
    assert f'processes of {shared.owner()} on this machine' in sentence


def test_nothing_is_reported_where_that_is_not_the_cause(shared, monkeypatch):
    """With other transports, another implementation of DDS, or another program's files."""
    monkeypatch.setattr(os, 'geteuid', lambda: 54321)
    with monkeypatch.context() as other:
        other.setenv('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
        assert unreached(shared) == ''
    with monkeypatch.context() as other:
        other.setattr(rclpy, 'get_rmw_implementation_identifier', lambda: 'rmw_cyclonedds_cpp')
        assert unreached(shared) == ''
    (shared / 'fastrtps_e0ca4075b2ea041c').rename(shared / 'sem.other')
    assert unreached(shared) == ''
