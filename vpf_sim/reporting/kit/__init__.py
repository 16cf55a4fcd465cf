"""What every page is made of: `page` and its macros, `table`, `chart`, `interval_chart`, `clip`."""
