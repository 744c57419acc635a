#!/usr/bin/env python3
"""Writes profile_tables.inc: the built-in profiles as integers, round(65536 w(i / 1024)), i = 0..1024.

Run once; the result is committed, so that no machine's libm decides about persistent ground. A test recomputes the
formulae in long double and compares."""
from decimal import Decimal, getcontext

getcontext().prec = 50
PI = Decimal("3.14159265358979323846264338327950288419716939937510")


def cosine(x):
    term, total, n = Decimal(1), Decimal(1), 0
    while abs(term) > Decimal(10) ** -45:
        n += 2
        term = -term * x * x / (n * (n - 1))
        total += term
    return total


EDGE = Decimal(-6).exp()
PROFILES = {
    "gaussian": lambda t: ((-6 * t * t).exp() - EDGE) / (1 - EDGE),
    "cone": lambda t: 1 - t,
    "paraboloid": lambda t: 1 - t * t,
    "cosine": lambda t: (1 + cosine(PI * t)) / 2,
    "crater": lambda t: (1 - t * t) ** 2 * (1 - 4 * t * t),
    "disc": lambda t: Decimal(1),
}

with open(__file__.replace("make_profile_tables.py", "profile_tables.inc"), "w") as out:
    out.write("// Written by make_profile_tables.py. Do not edit.\n")
    for name, weight in PROFILES.items():
        values = [int((weight(Decimal(i) / 1024) * 65536).to_integral_value("ROUND_HALF_EVEN")) for i in range(1025)]
        out.write(f"// {name}\n{{")
        line = ""
        for value in values:
            item = f"{value}, "
            if len(line) + len(item) > 116:
                out.write(line.rstrip() + "\n")
                line = ""
            line += item
        out.write(line.rstrip().rstrip(",") + "},\n")
