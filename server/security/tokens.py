"""Seat and admin tokens: 128 random bits, kept only as a hash, compared in constant time."""

import hashlib
import hmac
import secrets

Hash = bytes


def new_token() -> str:
    """A fresh secret for a URL-safe place (never a URL: it travels in messages and headers)."""
    return secrets.token_urlsafe(16)


def new_id(length: int = 12) -> str:
    """An unguessable name for a room or an episode: 5 bits per letter, none that people mix up."""
    return "".join(secrets.choice("abcdefghijkmnpqrstuvwxyz23456789") for _ in range(length))


def hash_token(token: str) -> Hash:
    """What is kept of a token. Tokens are random, so a plain hash is enough."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()


def token_matches(token: str, kept: Hash) -> bool:
    return hmac.compare_digest(hash_token(token), kept)
