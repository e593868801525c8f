"""Torques on the body, one in a file."""
