"""Reach of a start: the edges that bound it, those beyond a weak edge or a junction, and the rest."""
