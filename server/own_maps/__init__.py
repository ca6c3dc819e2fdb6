"""Maps that are not shipped: the files of the operator's folder, and maps that somebody has drawn."""
