/* Lets Debian 12's user-mode Linux (6.1) run on CPUs whose extended state is larger than the 2696 bytes that it was built
 * for (AMX: 11008). It writes a guest's registers back with PTRACE_SETREGSET of that size, which Linux takes only with the
 * CPU's full size, and its first process dies ("ptrace set fp regs failed, errno = 14"). Loaded before libc, this passes
 * the missing tail: what the process has there anyway. No guest uses it: that would take a permission that the guest's
 * kernel does not know of. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

static long (*ptrace_of_libc)(enum __ptrace_request, ...);

__attribute__((constructor)) static void find_ptrace_of_libc(void) {
    ptrace_of_libc = (long (*)(enum __ptrace_request, ...))dlsym(RTLD_NEXT, "ptrace");
}

long ptrace(enum __ptrace_request request, ...) {
    static char whole[1 << 16] __attribute__((aligned(64)));
    va_list rest;
    va_start(rest, request);
    pid_t pid = va_arg(rest, pid_t);
    void *address = va_arg(rest, void *);
    void *data = va_arg(rest, void *);
    va_end(rest);
    if (request == PTRACE_SETREGSET && address == (void *)NT_X86_XSTATE) {
        const struct iovec *given = data;
        struct iovec all = {whole, sizeof whole};
        if (ptrace_of_libc(PTRACE_GETREGSET, pid, address, &all) == 0 && given->iov_len < all.iov_len) {
            memcpy(whole, given->iov_base, given->iov_len);
            return ptrace_of_libc(request, pid, address, &all);
        }
    }
    return ptrace_of_libc(request, pid, address, data);
}
