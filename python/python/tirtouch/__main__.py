"""The command line: ``tirtouch``, or ``python -m tirtouch``."""

import os
import sys
import sysconfig

from ._tirtouch import _command_line


def main() -> None:
    """Runs the command that the arguments ask for and ends with its exit code."""
    program = os.path.join(sysconfig.get_path("scripts"), "tirtouch")
    sys.exit(_command_line(["tirtouch", *sys.argv[1:]], program))


if __name__ == "__main__":
    main()
