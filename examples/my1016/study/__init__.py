"""The source study of the MY1016: reproduced from its numbers, and compared with identification on the same data."""

import os

# The matrices are small: threads of the linear algebra library would only wait for each other. Set before numpy loads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
