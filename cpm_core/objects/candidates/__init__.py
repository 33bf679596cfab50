"""Candidates for the object that is meant by a click, and the choice among them.

Some dozens of regions around a click are candidates: where the gray levels are alike (`flooding`), what the cheapest
boundaries along contours enclose, disks and margins (`kinds`). Each is described by a few features (`features`),
and the one of the highest score is taken (`ranking`, `choice`).
"""
