"""Names that a model cannot have: generated C calls its files NAME.h, its types NAME_t, its functions NAME_predict."""

from __future__ import annotations

from typing import Final

_WORDS: Final = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl complex concept const
consteval constexpr constinit continue decltype default delete do double else enum explicit export extern false float
for friend goto if imaginary inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private
protected public register restrict return short signed sizeof static struct switch template this throw true try typedef
typeid typename union unsigned using virtual void volatile while xor xor_eq
"""
"""Keywords of C and C++."""

_HEADERS: Final = """
aio assert c6x cpio ctype dirent dlfcn errno fcntl fenv fmtmsg fnmatch ftw glob grp iconv inttypes iso646 langinfo
libgen limits locale math monetary mqueue ndbm netdb nl_types poll pthread pwd regex sched search semaphore setjmp
signal spawn stdalign stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string strings stropts syslog tar
termios tgmath threads time trace uchar ulimit unistd utime utmpx wchar wctype wordexp
"""
"""Standard headers of C and POSIX: with -I., `#include <float.h>` would find the model's."""

_TYPES: Final = """
blkcnt blksize clock clockid cnd dev div fpos fsblkcnt fsfilcnt gid id imaxdiv ino key ldiv lldiv mbstate mode mtx nlink
off pid ptrdiff size ssize suseconds thrd timer tss uid useconds wctrans wint caddr daddr fsid loff quad u_quad
int8 int16 int32 int64 uint8 uint16 uint32 uint64 intmax uintmax intptr uintptr int_fast8 int_fast16 int_fast32
int_fast64 int_least8 int_least16 int_least32 int_least64 uint_fast8 uint_fast16 uint_fast32 uint_fast64 uint_least8
uint_least16 uint_least32 uint_least64 char8 char16 char32 max_align
"""
"""Types NAME_t of C, C++ and POSIX."""

_OURS: Final = """
bank board bytes controller crc32 firmware frame hysgen image link main model number play settings siphash status store
trim watchdog
"""
"""Files of the controller and of generated folders."""

TAKEN: Final = frozenset(f"{_WORDS} {_HEADERS} {_TYPES} {_OURS}".split())
