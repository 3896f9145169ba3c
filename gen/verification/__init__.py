"""Proof of equality: the emitted C++ on the host and on an emulated Mega against the reference simulator."""
