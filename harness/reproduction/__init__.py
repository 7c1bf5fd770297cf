"""The source paper (Harper, Dufek and Breard, arXiv:2409.13633), statement by statement."""
