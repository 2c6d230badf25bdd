"""The benchmark: methods over sequences with known truth, judged as in the paper and strictly."""
