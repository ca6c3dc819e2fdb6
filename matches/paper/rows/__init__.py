"""What fills the rows of tables: play, measurements, definitions."""
