"""Animations and strips of snapshots, drawn off screen."""
