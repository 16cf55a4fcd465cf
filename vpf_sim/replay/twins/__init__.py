"""Rendered twins of recorded drives: what a driver reports on a recording, beside what it reports on its twin."""
