"""The bytes of a recording: topics, payloads, metadata, journal."""
