"""Pictures: figures are made from data and returned; only `style.save` writes."""
