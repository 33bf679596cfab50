"""Document, edits, and what follows from them (texts, hit testing); no Qt."""
