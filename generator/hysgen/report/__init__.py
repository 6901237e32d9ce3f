"""What people read: the verdict of a diagnosis in words, and pages of HTML that need nothing but themselves."""
