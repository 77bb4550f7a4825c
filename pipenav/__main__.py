"""`python -m pipenav`."""

from pipenav.cli import main

main()
