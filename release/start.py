"""Where the frozen application begins."""

import multiprocessing
import sys
from types import ModuleType

NAMED = {"PySide6.QtOpenGL": None, "scipy.optimize": "minimize_scalar", "scipy.stats": "scoreatpercentile"}
"""Large modules of which pyqtgraph and SciPy import a name that the program never uses, so that they are left out."""

for name, function in NAMED.items():
    sys.modules[name] = ModuleType(name)
    if function is not None:
        setattr(sys.modules[name], function, None)

if __name__ == "__main__":
    multiprocessing.freeze_support()  # a process of a batch ends here
    from cpm_app.__main__ import main

    sys.exit(main())
