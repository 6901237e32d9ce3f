"""Names that a model cannot have: generated C calls its files NAME.h, its types NAME_t, its functions NAME_predict."""

from typing import Final

_WORDS: Final = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t class co_await
co_return co_yield compl complex concept const const_cast consteval constexpr constinit continue d_fileno decltype
default delete do double dynamic_cast else enum errno explicit export extern false float for friend goto h_addr
h_errno if imaginary inline int linux long math_errhandling msg_cbytes mutable namespace new noexcept noreturn not
not_eq nullptr operator or or_eq private protected public register reinterpret_cast requires restrict return
sched_priority short signed sizeof st_atime st_ctime st_mtime static static_assert static_cast stderr stdin stdout
struct switch template this thread_local throw true try typedef typeid typename typeof typeof_unqual union unix
unsigned using virtual void volatile wchar_t while xor xor_eq
"""
"""Keywords of C and C++, and macros that stand for a variable: a program calls its model by its name."""

_HEADERS: Final = """
aio alloca assert byteswap c6x cpio ctype dirent dlfcn endian errno fcntl features fenv fmtmsg fnmatch ftw glob grp
iconv inttypes iso646 langinfo libgen limits locale math memory monetary mqueue ndbm netdb newlib nl_types paths poll
pthread pwd reent regex sched search semaphore setjmp signal spawn stdalign stdarg stdatomic stdbit stdbool stdckdint
stddef stdint stdio stdlib stdnoreturn string strings stropts syslimits syslog tar termios tgmath threads time trace
uchar ulimit unistd utime utmpx wchar wctype wordexp
"""
"""Standard headers of C and POSIX, and those that they include: with -I., <float.h> would be the model's."""

_TYPES: Final = """
active_reg blkcnt blksize caddr cc char16 char32 char8 clock clockid cnd comparison_fn cpu_set daddr dev div error
femode fexcept fpos fpregset fsblkcnt fsfilcnt fsid gid greg gregset id idtype imaxdiv in_addr in_port ino int16 int32
int64 int8 intmax intptr key ldiv lldiv loff max_align mbstate mcontext mode mqd msglen msgqnum mtx nfds nlink off
once_flag pid ptrdiff quad re_dfa regmatch regoff rlim s_reg sem shmatt sig sigaction sigevent sighandler siginfo
sigset sigval size socklen speed ssize stack suseconds tcflag thrd timer tss u_int16 u_int32 u_int64 u_int8 u_quad
ucontext uid uint16 uint32 uint64 uint8 uintmax uintptr useconds wctrans wint
"""
"""Types NAME_t of C, C++, POSIX and glibc."""

_FAMILIES: Final = """
atomic cookie_ hysgen ifa_ ifc_ ifr_ inet6 int_fast int_least lc_ posix pthread reg_ s6_ sa_ si_ sig_ sigev_ uint_fast
uint_least
"""
"""Beginnings of further types, functions, macros and files."""

_ENDINGS: Final = ("_bank", "_c674x", "_component", "_fmu", "_learner", "_params", "_selftest", "_selftest_data")
"""Endings of types and files of another model: of `stage` beside `stage_bank`."""

_OURS: Final = """
bank board board_ring bytes controller controller_state crc32 firmware frame image image_bench image_owner integrity
link linkage main model number play settings siphash status store trace watchdog watchdog_count
"""
"""Files of the controller and of generated folders."""

TAKEN: Final = frozenset(f"{_WORDS} {_HEADERS} {_TYPES} {_OURS}".split())


def fault_of_name(name: str) -> str:
    """Why a model cannot be called so, "" if it can."""
    if not name.isidentifier() or not name.isascii() or name != name.lower():
        return f"name: {name!r} cannot prefix C functions; use lower-case letters, digits and _"
    taken = f"name: {name!r} is a word, header or type of C or a file of hysgen's; choose another"
    return taken if is_taken(name) else ""


def is_taken(name: str) -> bool:
    """Whether generated C of this name would collide with C, C++, POSIX, hysgen's own files or another model's."""
    return (
        not TAKEN.isdisjoint({name, name.removesuffix("64")})
        or name.startswith(tuple(_FAMILIES.split()))
        or name.endswith(_ENDINGS)
    )
