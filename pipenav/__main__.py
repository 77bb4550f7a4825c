"""The command line, as `python -m pipenav`."""

from pipenav.processes.safe_path import leave_current_folder

leave_current_folder()  # before anything is imported that could lie in the current folder

from pipenav.cli import main  # noqa: E402

main()
