/* Where the server of `ricochet view` listens. */
#define _POSIX_C_SOURCE 200809L

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "view.h"

enum { PORTS_TRIED = 20 };

static bool is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET)
        return ntohl(((const struct sockaddr_in *)(const void *)address)->sin_addr.s_addr) >> 24 ==
               127;
    return IN6_IS_ADDR_LOOPBACK(&((const struct sockaddr_in6 *)(const void *)address)->sin6_addr);
}

/* A listening socket, or -1 with errno. */
static int listen_at(const struct addrinfo *where, int port)
{
    struct sockaddr_storage address;
    const int one = 1, fd = socket(where->ai_family, SOCK_STREAM, 0);
    memcpy(&address, where->ai_addr, where->ai_addrlen);
    if (where->ai_family == AF_INET)
        ((struct sockaddr_in *)&address)->sin_port = htons((uint16_t)port);
    else ((struct sockaddr_in6 *)&address)->sin6_port = htons((uint16_t)port);
    if (fd < 0) return -1;
    fcntl(fd, F_SETFD, FD_CLOEXEC);
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    if (bind(fd, (struct sockaddr *)&address, where->ai_addrlen) || listen(fd, 64)) {
        const int reason = errno;
        close(fd);
        errno = reason;
        return -1;
    }
    return fd;
}

static int port_of(int fd)
{
    struct sockaddr_storage address;
    socklen_t n = sizeof address;
    if (getsockname(fd, (struct sockaddr *)&address, &n)) return 0;
    return ntohs(address.ss_family == AF_INET ? ((struct sockaddr_in *)&address)->sin_port
                                              : ((struct sockaddr_in6 *)&address)->sin6_port);
}

bool view_address_valid(const char *text)
{
    unsigned char bytes[16];
    return inet_pton(AF_INET, text, bytes) == 1 || inet_pton(AF_INET6, text, bytes) == 1;
}

int view_socket_open(const view_listen *where, view_socket *out)
{
    const struct addrinfo hints = {.ai_flags = AI_NUMERICHOST, .ai_socktype = SOCK_STREAM};
    const char *address = where->address ? where->address : "127.0.0.1";
    struct addrinfo *found = NULL;
    int fd = -1, tried = 0;
    if (getaddrinfo(address, NULL, &hints, &found)) return -1;
    do fd = listen_at(found, where->port ? where->port + tried : 0);
    while (fd < 0 && errno == EADDRINUSE && !where->exact && ++tried < PORTS_TRIED &&
           where->port + tried < 65536);
    if (fd < 0)
        cli_say("ricochet: cannot listen at %s, port %d: %s; choose another one with --port\n",
                address, where->port, strerror(errno));
    else {
        out->loopback = is_loopback(found->ai_addr);
        out->port = port_of(fd);
        snprintf(out->origin, sizeof out->origin,
                 found->ai_family == AF_INET6 ? "http://[%s]:%d" : "http://%s:%d", address,
                 out->port);
    }
    freeaddrinfo(found);
    return fd;
}
