#include <openssl/bio.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/rand.h>
#include <openssl/sha.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <cstddef>
#include <cstdint>

#include "environment/base/loaded_library.h"

// The functions of OpenSSL that Asio, Beast and the server use; its libraries are loaded when one is called first.

namespace {

const espalier::environment::LoadedLibrary kTls("libssl.so.3", "libssl3");
const espalier::environment::LoadedLibrary kCryptography("libcrypto.so.3", "libssl3");

}  // namespace

#define ESPALIER_TLS(result, name, parameters, arguments) ESPALIER_LOADED(kTls, result, name, parameters, arguments)
#define ESPALIER_CRYPTO(result, name, parameters, arguments) \
  ESPALIER_LOADED(kCryptography, result, name, parameters, arguments)

extern "C" {

ESPALIER_TLS(const SSL_METHOD*, TLS_client_method, (), ())
ESPALIER_TLS(const SSL_METHOD*, TLS_server_method, (), ())
ESPALIER_TLS(const SSL_METHOD*, TLS_method, (), ())

ESPALIER_TLS(SSL_CTX*, SSL_CTX_new, (const SSL_METHOD* method), (method))
ESPALIER_TLS(void, SSL_CTX_free, (SSL_CTX * context), (context))
ESPALIER_TLS(long, SSL_CTX_ctrl, (SSL_CTX * context, int command, long number, void* data),
             (context, command, number, data))
ESPALIER_TLS(std::uint64_t, SSL_CTX_set_options, (SSL_CTX * context, std::uint64_t options), (context, options))
ESPALIER_TLS(void*, SSL_CTX_get_ex_data, (const SSL_CTX* context, int index), (context, index))
ESPALIER_TLS(int, SSL_CTX_set_ex_data, (SSL_CTX * context, int index, void* data), (context, index, data))
ESPALIER_TLS(void*, SSL_CTX_get_default_passwd_cb_userdata, (SSL_CTX * context), (context))
ESPALIER_TLS(void, SSL_CTX_set_default_passwd_cb_userdata, (SSL_CTX * context, void* data), (context, data))
ESPALIER_TLS(int, SSL_CTX_set_default_verify_paths, (SSL_CTX * context), (context))
ESPALIER_TLS(int, SSL_CTX_load_verify_locations, (SSL_CTX * context, const char* file, const char* folder),
             (context, file, folder))
ESPALIER_TLS(int, SSL_CTX_check_private_key, (const SSL_CTX* context), (context))
ESPALIER_TLS(int, SSL_CTX_use_PrivateKey_file, (SSL_CTX * context, const char* file, int type), (context, file, type))
ESPALIER_TLS(int, SSL_CTX_use_certificate_chain_file, (SSL_CTX * context, const char* file), (context, file))

ESPALIER_TLS(SSL*, SSL_new, (SSL_CTX * context), (context))
ESPALIER_TLS(void, SSL_free, (SSL * stream), (stream))
ESPALIER_TLS(long, SSL_ctrl, (SSL * stream, int command, long number, void* data), (stream, command, number, data))
ESPALIER_TLS(void, SSL_set_bio, (SSL * stream, BIO* reader, BIO* writer), (stream, reader, writer))
ESPALIER_TLS(void*, SSL_get_ex_data, (const SSL* stream, int index), (stream, index))
ESPALIER_TLS(int, SSL_set_ex_data, (SSL * stream, int index, void* data), (stream, index, data))
ESPALIER_TLS(int, SSL_get_ex_data_X509_STORE_CTX_idx, (), ())
ESPALIER_TLS(int, SSL_get_verify_mode, (const SSL* stream), (stream))
ESPALIER_TLS(SSL_verify_cb, SSL_get_verify_callback, (const SSL* stream), (stream))
ESPALIER_TLS(void, SSL_set_verify, (SSL * stream, int mode, SSL_verify_cb callback), (stream, mode, callback))
ESPALIER_TLS(int, SSL_accept, (SSL * stream), (stream))
ESPALIER_TLS(int, SSL_connect, (SSL * stream), (stream))
ESPALIER_TLS(int, SSL_read, (SSL * stream, void* bytes, int count), (stream, bytes, count))
ESPALIER_TLS(int, SSL_write, (SSL * stream, const void* bytes, int count), (stream, bytes, count))
ESPALIER_TLS(int, SSL_shutdown, (SSL * stream), (stream))
ESPALIER_TLS(int, SSL_get_shutdown, (const SSL* stream), (stream))
ESPALIER_TLS(int, SSL_get_error, (const SSL* stream, int result), (stream, result))

ESPALIER_CRYPTO(long, BIO_ctrl, (BIO * bio, int command, long number, void* data), (bio, command, number, data))
ESPALIER_CRYPTO(std::size_t, BIO_ctrl_pending, (BIO * bio), (bio))
ESPALIER_CRYPTO(int, BIO_new_bio_pair, (BIO * *first, std::size_t firstBytes, BIO** second, std::size_t secondBytes),
                (first, firstBytes, second, secondBytes))
ESPALIER_CRYPTO(int, BIO_free, (BIO * bio), (bio))
ESPALIER_CRYPTO(int, BIO_read, (BIO * bio, void* bytes, int count), (bio, bytes, count))
ESPALIER_CRYPTO(int, BIO_write, (BIO * bio, const void* bytes, int count), (bio, bytes, count))

ESPALIER_CRYPTO(void, ERR_clear_error, (), ())
ESPALIER_CRYPTO(unsigned long, ERR_get_error, (), ())
ESPALIER_CRYPTO(const char*, ERR_lib_error_string, (unsigned long error), (error))
ESPALIER_CRYPTO(const char*, ERR_reason_error_string, (unsigned long error), (error))

ESPALIER_CRYPTO(X509*, X509_STORE_CTX_get_current_cert, (const X509_STORE_CTX* store), (store))
ESPALIER_CRYPTO(int, X509_STORE_CTX_get_error_depth, (const X509_STORE_CTX* store), (store))
ESPALIER_CRYPTO(void*, X509_STORE_CTX_get_ex_data, (const X509_STORE_CTX* store, int index), (store, index))
ESPALIER_CRYPTO(int, X509_check_host,
                (X509 * certificate, const char* name, std::size_t length, unsigned flags, char** peerName),
                (certificate, name, length, flags, peerName))
ESPALIER_CRYPTO(int, X509_check_ip_asc, (X509 * certificate, const char* address, unsigned flags),
                (certificate, address, flags))

ESPALIER_CRYPTO(void, CRYPTO_free, (void* memory, const char* file, int line), (memory, file, line))
ESPALIER_CRYPTO(int, CRYPTO_memcmp, (const void* first, const void* second, std::size_t count), (first, second, count))
ESPALIER_CRYPTO(int, RAND_bytes, (unsigned char* bytes, int count), (bytes, count))
ESPALIER_CRYPTO(unsigned char*, SHA256, (const unsigned char* bytes, std::size_t count, unsigned char* digest),
                (bytes, count, digest))

}  // extern "C"
