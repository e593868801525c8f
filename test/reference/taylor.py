"""
Taylor integration of ordinary differential equations to fifty digits (Jorba and Zou 2005).

The right-hand side is written once, in power series of time: a product is a convolution of
coefficients, so that each order of the unknowns gives their rates to that order, and these the
next order of the unknowns. Nothing here knows mechanics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from operator import mul

import gmpy2
from gmpy2 import mpfr

gmpy2.get_context().precision = 190
ORDER = 50
# A step of 1/e^2 of the radius of convergence leaves exp(-2 ORDER), 4e-44 of the largest value.
FRACTION = gmpy2.exp(mpfr(-2))


class Series:
    """A power series of time whose coefficients are appended one by one, in order."""

    def __init__(self, coefficient: Callable[[int], mpfr], *terms: Series) -> None:
        """coefficient(k): the k-th coefficient, from those up to k of the terms it is made of."""
        self.coefficient, self.terms = coefficient, terms
        self.c: list[mpfr] = []

    def __add__(self, other: Series | mpfr | int) -> Series:
        """Return the sum with a series or a number."""
        if not isinstance(other, Series):
            return Series(lambda k: self.c[k] if k else self.c[0] + other, self) if other else self
        return Series(lambda k: self.c[k] + other.c[k], self, other)

    __radd__ = __add__

    def __sub__(self, other: Series | mpfr | int) -> Series:
        """Return the difference from a series or a number."""
        return self + other * -1

    def __rsub__(self, other: mpfr | int) -> Series:
        """Return a number less the series."""
        return self * -1 + other

    def __mul__(self, other: Series | mpfr | int) -> Series | mpfr:
        """Return the product with a series (Cauchy's) or a number; with 0 it is the number 0."""
        if not isinstance(other, Series):
            return Series(lambda k: other * self.c[k], self) if other else mpfr(0)
        return Series(lambda k: sum(map(mul, self.c, reversed(other.c)), mpfr(0)), self, other)

    __rmul__ = __mul__

    def __pow__(self, exponent: mpfr) -> Series:
        """Return the series raised to any real power; its value must be positive."""

        def coefficient(k: int) -> mpfr:
            if k == 0:
                return self.c[0] ** exponent
            terms = ((exponent * (k - j) - j) * self.c[k - j] * power.c[j] for j in range(k))
            return sum(terms, mpfr(0)) / (k * self.c[0])

        power = Series(coefficient, self)
        return power


class Unknowns:
    """Unknowns of a system of equations: their values now, and their rates as series of them."""

    def __init__(self, values: list[mpfr]) -> None:
        """values: at the start, in the order of the series self.x."""
        self.values = list(values)
        self.x = [Series(lambda k: mpfr(0)) for _ in values]

    def integrate(
        self, rates: list[Series | mpfr], times: list[mpfr], leading: list[slice]
    ) -> Iterator[list[mpfr]]:
        """
        Yield the values at each of the times, which rise from 0.

        rates: d/dt of each unknown. leading: groups of unknowns of one size whose coefficients
        choose the step; the others follow from them.
        """
        series = [rate if isinstance(rate, Series) else _constant(rate) for rate in rates]
        order = _in_order(series, set(map(id, self.x)))
        now = mpfr(0)
        step = self._expand(series, order, leading)
        for time in times:
            while now + step < time:
                self.values = [_sum(x.c, step) for x in self.x]
                now += step
                step = self._expand(series, order, leading)
            yield [_sum(x.c, time - now) for x in self.x]

    def _expand(self, rates: list[Series], order: list[Series], leading: list[slice]) -> mpfr:
        """Lay the coefficients of all series about the values now; return the step they allow."""
        for series in order:
            series.c.clear()
        for x, value in zip(self.x, self.values, strict=True):
            x.c[:] = [value]
        for k in range(ORDER):
            for series in order:
                series.c.append(series.coefficient(k))
            for x, rate in zip(self.x, rates, strict=True):
                x.c.append(rate.c[k] / (k + 1))
        return FRACTION * min(_radius(self.x[group]) for group in leading)


def _constant(value: mpfr) -> Series:
    """Return the series of a number."""
    return Series(lambda k: value if k == 0 else mpfr(0))


def _in_order(rates: list[Series], done: set[int]) -> list[Series]:
    """Return all series that the rates are made of, each after its terms."""
    order: list[Series] = []

    def visit(series: Series) -> None:
        if id(series) not in done:
            done.add(id(series))
            for term in series.terms:
                visit(term)
            order.append(series)

    for rate in rates:
        visit(rate)
    return order


def _radius(group: list[Series]) -> mpfr:
    """Return the radius of convergence that the last two coefficients of a group give."""
    sizes = {k: max((abs(x.c[k]) for x in group), default=mpfr(0)) for k in (0, ORDER - 1, ORDER)}
    radii = [(sizes[0] / s) ** (mpfr(1) / k) for k, s in sizes.items() if k and s]
    return min(radii, default=gmpy2.inf())


def _sum(coefficients: list[mpfr], step: mpfr) -> mpfr:
    """Return the value of a series after a step (Horner)."""
    value = mpfr(0)
    for c in reversed(coefficients):
        value = value * step + c
    return value
