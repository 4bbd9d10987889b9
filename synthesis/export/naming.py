"""The name of a joint as an identifier of C, C++ and Python and as a file, and within their comments and texts."""

from __future__ import annotations

import re
from hashlib import sha256
from keyword import iskeyword, issoftkeyword
from unicodedata import normalize

OTHERS = re.compile(r"[^A-Za-z0-9]+")
LONGEST = 40  # characters; C99 tells external names apart by their first 31, every C and C++ compiler by far more
# of C and C++ up to 2023, extensions of compilers for embedded processors, and macros of old ones
KEYWORDS = """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t char8_t
class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit continue decltype
default delete do double dynamic_cast else enum explicit export extern false float for friend goto if import inline
int long module mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public
register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct
switch template this thread_local throw true try typedef typeid typename typeof typeof_unqual union unsigned using
virtual void volatile wchar_t while xor xor_eq near far interrupt linux unix i386 vax"""
# headers, types and functions of C and of POSIX that a name alone would hide
LIBRARY = """abort abs acos acosh alloca asctime asin asinh assert atan atan2 atanh atexit atof atoi atol atoll bcmp
bcopy bsearch bzero cabs calloc carg cbrt ceil cexp cimag clearerr clock conj copysign cos cosh cpow creal csin
csqrt ctan ctime ctype difftime div errno erf erfc exit exp exp2 exp10 expm1 fabs fclose fdim fenv feof ferror
fflush ffs fgetc fgets floor fma fmax fmin fmod fopen fork fprintf fputc fputs fread free frexp fscanf fseek ftell
fwrite gamma getc getchar getenv gets gmtime hypot ilogb imaxabs index inttypes isalnum isalpha iscntrl isdigit
islower isnan isprint ispunct isspace isupper j0 j1 jn labs ldexp ldiv lgamma limits llabs lldiv llrint locale
localtime log log10 log1p log2 logb longjmp lrint lround main malloc math memchr memcmp memcpy memmove memset mktime
modf nan nearbyint nextafter perror pow printf putc putchar puts qsort raise rand random realloc remainder remove
remquo rename rewind rindex rint round scalb scalbn scanf select setbuf setjmp setlocale setvbuf signal signbit
significand sin sincos sinh snprintf sprintf sqrt srand sscanf std stdarg stdbool stddef stderr stdin stdint stdio
stdlib stdout strcat strchr strcmp strcpy strdup strftime string strings strlen strncat strncmp strncpy strndup
strpbrk strrchr strspn strstr strtod strtok strtol strtoul system tan tanh tgamma time tolower toupper trunc ungetc
unistd vprintf vsnprintf wait write y0 y1 yn"""
OWN = "c control filtered functools numpy operator real scipy settled started zeroed"  # of the files themselves
TAKEN = frozenset(f"{KEYWORDS} {LIBRARY} {OWN}".split())


def identifier(name: str) -> str:
    """A name that compilers take and libraries leave alone; different names of no Latin letter stay different."""
    latin = normalize("NFKD", name).encode("ascii", "ignore").decode()
    plain = OTHERS.sub("_", latin).strip("_").lower()
    digest = sha256(name.encode()).hexdigest()[:8]
    if not plain:
        return f"joint_{digest}"
    if len(plain) > LONGEST:
        plain = f"{plain[: LONGEST - 9].strip('_')}_{digest}"
    taken = plain in TAKEN or iskeyword(plain) or issoftkeyword(plain) or plain.endswith("_t")
    return f"joint_{plain}" if taken or not plain[0].isalpha() else plain


def remark(name: str) -> str:
    """The name within a comment or a text between quotes: on one line, without what would end either."""
    return re.sub(r"[^\w .,:;()+=%-]+", " ", name).strip()
