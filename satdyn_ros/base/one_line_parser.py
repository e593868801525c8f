"""A parser of arguments that says what is wrong with them in one line."""

import argparse
from typing import NoReturn

INPUT_IS_WRONG = 2


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        """Exit with the line, and INPUT_IS_WRONG."""
        self.exit(INPUT_IS_WRONG, f'{self.prog}: {message}; see {self.prog} --help\n')
