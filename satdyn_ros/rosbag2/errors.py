"""What can be wrong with a bag, each stated in one sentence."""

from pathlib import Path


class BagError(ValueError):
    """A path that is not a bag, or a bag that cannot be read."""


class Damaged(BagError):  # noqa: N818
    """A bag whose bytes are not those its writer wrote."""


class Incomplete(Damaged):
    """A file whose writer did not finish it."""

    def __init__(self, path: Path):
        super().__init__(f'{path} ends in mid-write; satdyn recover completes it')
