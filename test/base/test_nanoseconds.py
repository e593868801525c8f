"""Stamps and epochs."""

from datetime import datetime, timezone

import pytest

from satdyn_ros.base import nanoseconds


def test_an_epoch_keeps_the_nanosecond():
    """As the calendar of the standard library has it, with all nine decimals."""
    stamp_ns = 1_709_210_096_000_000_001
    calendar = datetime.fromtimestamp(1_709_210_096, timezone.utc)
    assert nanoseconds.epoch(stamp_ns) == f'{calendar:%Y-%m-%dT%H:%M:%S}.000000001'
    assert nanoseconds.stamp_ns(nanoseconds.epoch(stamp_ns)) == stamp_ns
    assert nanoseconds.epochs([0, 10**9]) == [
        '1970-01-01T00:00:00.000000000',
        '1970-01-01T00:00:01.000000000',
    ]


@pytest.mark.parametrize(
    'text',
    ['2024-02-29T12:34:56', '2024-060T12:34:56Z', '2024-02-29T12:34:56.0000000001'],
)
def test_both_forms_are_read(text):
    """Calendar date or day of the year, with Z or without; rounded to a nanosecond."""
    instant = datetime(2024, 2, 29, 12, 34, 56, tzinfo=timezone.utc)
    assert nanoseconds.stamp_ns(text) == int(instant.timestamp()) * 10**9


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('noon', 'is not an epoch; give UTC as'),
        ('2024-02-30T00:00:00', 'is not an epoch: day'),
        ('2023-366T00:00:00', 'is not an epoch: the year has no day 366'),
        ('2016-12-31T23:59:60', 'is a leap second'),
        ('9999-12-31T23:59:59', 'the epoch 9999-12-.* out of range; it must be between 1677 and'),
        ('0001-01-01T00:00:00', 'the epoch 0001-01-.* out of range; it must be between 1677 and'),
    ],
)
def test_what_is_no_epoch_is_refused(text, reason):
    """In one sentence."""
    with pytest.raises(ValueError, match=reason):
        nanoseconds.stamp_ns(text)
