"""Hold a backend to its laws, after pip install examples/backend: python examples/own_backend.py [BACKEND]"""

import sys

from pipenav.testing import ALL_LAWS, Bench

bench = Bench(sys.argv[1] if len(sys.argv) > 1 else "lag")  # an installed backend's name, or a class

broken = 0
for law in ALL_LAWS:
    try:
        law(bench)
        print(f"kept    {law.__name__}")
    except AssertionError as error:
        broken += 1
        print(f"BROKEN  {law.__name__}: {error}")
print(f"{len(ALL_LAWS) - broken} of {len(ALL_LAWS)} laws kept")
sys.exit(broken > 0)
