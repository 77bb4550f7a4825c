"""The command line, as `python -m pipenav`."""

from pipenav.cli import main

main()
