"""Where the frozen application begins."""

import multiprocessing
import sys

if __name__ == "__main__":
    multiprocessing.freeze_support()  # a process of a batch ends here
    from cpm_app.__main__ import main

    sys.exit(main())
