"""Surfaces from points alone, without the volume in which they were found."""
