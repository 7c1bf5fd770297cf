"""A ball that bounces on a fixed sphere, as a case of dem-harness."""
