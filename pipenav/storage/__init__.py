"""Files and folders that appear complete or not at all, and the place of shipped data."""
