#!/usr/bin/env python3
"""Complete elliptic integrals and contact constants to 30 digits, for host_tests/judge/src/validation/cases.rs.

    python3 -m pip install mpmath
    cd host_tests/judge/cases && python3 hertz.py

writes elliptic_integrals.csv and hertz_contacts.csv. The integrals are quadratures of their definitions,
not the arithmetic-geometric mean that the library uses; that mpmath's own functions agree is checked.
"""
from mpmath import mp, mpf, quad, sin, sqrt, pi, findroot, linspace, ellipk, ellipe, nstr

mp.dps = 50
DIGITS = 30


def integrals(m):
    """K(m) and E(m) by tanh-sinh quadrature of their definitions."""
    # The integrand of K has its peak at the upper end, narrow if m is close to 1.
    pieces = [0, pi / 4, pi / 2 - mpf(1) / 10, pi / 2 - mpf(1) / 1000, pi / 2 - mpf(1) / 100000, pi / 2]
    k = quad(lambda t: 1 / sqrt(1 - m * sin(t) ** 2), pieces)
    e = quad(lambda t: sqrt(1 - m * sin(t) ** 2), pieces)
    assert abs(k / ellipk(m) - 1) < mpf(10) ** -DIGITS and abs(e / ellipe(m) - 1) < mpf(10) ** -DIGITS, m
    return k, e


def contact(rolling, across):
    """kappa, E and K of Q = K delta^1.5 for compliance 1 (Hertz 1881; Harris, Rolling Bearing Analysis)."""
    total = rolling + across
    wanted = (rolling - across) / total

    def difference(kappa):
        m = 1 - 1 / kappa ** 2
        return ((kappa ** 2 + 1) * ellipe(m) - 2 * ellipk(m)) / ((kappa ** 2 - 1) * ellipe(m)) - wanted

    kappa = findroot(difference, mpf("1.0339") * (rolling / across) ** mpf("0.636"))
    k, e = integrals(1 - 1 / kappa ** 2)
    d = 2 * k / pi * (pi / (2 * kappa ** 2 * e)) ** (mpf(1) / 3)
    return kappa, e, 2 * total / 3 * (2 / (d * total)) ** mpf("1.5")


with open("elliptic_integrals.csv", "w") as f:
    f.write("m,k,e\n")
    # Exact in binary and decimal: 1 - 2^-n and some multiples of 1/16.
    values = [mpf(0)] + [mpf(i) / 16 for i in (1, 4, 8, 12, 14)] + [1 - mpf(2) ** -n for n in range(4, 21, 2)]
    for m in values:
        k, e = integrals(m)
        f.write(f"{nstr(m, 25, strip_zeros=True)},{nstr(k, DIGITS)},{nstr(e, DIGITS)}\n")

with open("hertz_contacts.csv", "w") as f:
    f.write("rolling,across,kappa,e,load_deflection\n")
    # Curvatures that are exact in binary.
    for rolling, across in [(9, 8), (5, 4), (3, 2), (2, 1), (4, 1), (8, 1), (16, 1), (24, 1), (32, 1), (64, 1), (256, 1)]:
        kappa, e, k = contact(mpf(rolling), mpf(across))
        f.write(f"{rolling},{across},{nstr(kappa, DIGITS)},{nstr(e, DIGITS)},{nstr(k, DIGITS)}\n")
