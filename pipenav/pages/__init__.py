"""Reports as single HTML files, which load nothing from anywhere: their style, their helpers, their data."""
