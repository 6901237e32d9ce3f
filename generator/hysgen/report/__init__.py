"""Results for readers: a diagnosis as text, HTML pages that need no other file, pictures."""
