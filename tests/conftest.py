"""Before any test imports a numerical library: one thread each, since the tests themselves run side by side."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
