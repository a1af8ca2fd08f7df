"""The line below late events with the least sum of distances, as a linear program, for the test `the_line_is_that_of_the_linear_program` in
crates/piezotact-audio/src/force/late.rs; and checksums of docs/force-cell.md.

    python3 golden/force_clock.py

Made with SciPy 1.17.1 and NumPy 2.4.6.
"""

from functools import reduce

import numpy as np
from scipy.optimize import linprog

i = np.arange(60)
device_s = 0.5 * i + 0.1
late_s = 7.0 - 150e-6 * device_s + 0.004 * (1.0 + np.sin(0.37 * i * i))
middle_s = device_s.mean()
x = device_s - middle_s
# Largest sum of the line's values below the events: a·n + b·sum(x), with a + b·x <= late.
found = linprog(
    [-len(x), -x.sum()],
    A_ub=np.column_stack([np.ones_like(x), x]),
    b_ub=late_s,
    bounds=[(None, None)] * 2,
    method="highs",
)
print(f"late {found.x[0]:.12f} drift {found.x[1]:.6e}")
for line in ("F 1000 204.5", "F 1012 204.7"):
    print(f"{line}*{reduce(lambda a, b: a ^ b, line.encode()):02X}")
