"""What the user means (document, edits) and what follows from it (resolve, hit testing); no Qt."""
