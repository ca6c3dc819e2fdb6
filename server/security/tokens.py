"""Seat and admin tokens: 128 random bits, kept only as a hash, compared in constant time. And pseudonyms."""

import hashlib
import hmac
import secrets

Hash = bytes


ID_LETTERS = "abcdefghijkmnpqrstuvwxyz23456789"  # without those that look alike


def new_token() -> str:
    """A new secret of URL-safe letters (it travels in messages and headers, never in a URL)."""
    return secrets.token_urlsafe(16)


def new_id(length: int = 12) -> str:
    """An unguessable name of a room or episode: 5 bits per letter."""
    return "".join(secrets.choice(ID_LETTERS) for _ in range(length))


def hash_token(token: str) -> Hash:
    """The hash that is stored of a token. Tokens are random, so a plain hash is enough."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()


def pseudonym(name: str, secret: str) -> str:
    """The same for the same name, and nobody without the secret can tell which."""
    return hmac.digest(secret.encode(), name.encode("utf-8", "surrogatepass"), "sha256")[:12].hex()


def token_matches(token: str, kept: Hash) -> bool:
    return hmac.compare_digest(hash_token(token), kept)
