"""Certificate authority of a deployment: issues short certificates for elliptic-curve keys."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from typing import Final, Self

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
from passafe_protocol.identity import ROUTER, Identity

AUTHORITY_DAYS: Final = 3650
CERTIFICATE_DAYS: Final = 365
LOCAL_HOSTS: Final = ("localhost", "127.0.0.1", "::1")
"""Names by which every router is reached from its own host."""

_CLOCK_SKEW: Final = timedelta(minutes=5)
"""How far before now certificates begin, for hosts whose clocks are behind."""


@dataclass(frozen=True, kw_only=True, slots=True)
class KeyPair:
    """Certificate with its private key, both as PEM.

    Attributes:
        certificate: The certificate.
        key: The key, not encrypted: processes start without a person.
    """

    certificate: bytes
    key: bytes


class Authority:
    """Certificate authority that signs the certificates of one deployment.

    Args:
        certificate: Its own certificate.
        key: Its private key.
    """

    def __init__(self, certificate: x509.Certificate, key: ec.EllipticCurvePrivateKey) -> None:
        self._certificate = certificate
        self._key = key

    @classmethod
    def create(cls, days: float = AUTHORITY_DAYS) -> Self:
        """Return a new authority, valid for ``days``."""
        key = ec.generate_private_key(ec.SECP256R1())
        name = _named("passafe authority")
        usage = _key_usage(signs_certificates=True)
        builder = (
            _lasting(x509.CertificateBuilder(), days)
            .subject_name(name)
            .issuer_name(name)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
            .add_extension(usage, critical=True)
            .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        )
        return cls(builder.sign(key, hashes.SHA256()), key)

    @property
    def pair(self) -> KeyPair:
        """Its own certificate and key."""
        return KeyPair(certificate=_pem(self._certificate), key=_key_pem(self._key))

    def issue(self, identity: Identity, *, hosts: Sequence[str] = (), days: float = CERTIFICATE_DAYS) -> KeyPair:
        """Issue a certificate for a new key.

        A process gets one that only opens sessions, so that it cannot pose as the router. No certificate outlasts the
        authority's own.

        Args:
            identity: Its holder.
            hosts: Router: further names and addresses by which it is reached.
            days: How long it is valid.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        purposes = [ExtendedKeyUsageOID.CLIENT_AUTH]
        names: list[x509.GeneralName] = [x509.DNSName(identity.common_name)]
        if identity.role == ROUTER:
            purposes.append(ExtendedKeyUsageOID.SERVER_AUTH)
            names += map(_host_name, dict.fromkeys((*LOCAL_HOSTS, *hosts)))
        authority_key = x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key())
        builder = (
            _lasting(x509.CertificateBuilder(), days, self._certificate.not_valid_after_utc)
            .subject_name(_named(identity.common_name))
            .issuer_name(self._certificate.subject)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_key_usage(signs_certificates=False), critical=True)
            .add_extension(x509.ExtendedKeyUsage(purposes), critical=False)
            .add_extension(x509.SubjectAlternativeName(names), critical=False)
            .add_extension(authority_key, critical=False)
        )
        return KeyPair(certificate=_pem(builder.sign(self._key, hashes.SHA256())), key=_key_pem(key))


def _named(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _lasting(builder: x509.CertificateBuilder, days: float, at_most: datetime | None = None) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    ends = now + timedelta(days=days)
    return builder.not_valid_before(now - _CLOCK_SKEW).not_valid_after(ends if at_most is None else min(ends, at_most))


def _key_usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _host_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _key_pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
