// SPDX-License-Identifier: MIT
//
// Names that headers of others define as macros: C's <complex.h>, X11, <windows.h> (but for min and max, which error.hpp refuses), <termios.h>
// with <sys/sysmacros.h> and <sys/param.h>, Qt. They are defined here as what cannot be compiled. No header of qdot says one of them.
// clang-format off

// <complex.h>
#define I ) complex_h (
#define imaginary ) complex_h (
#define _Complex_I ) complex_h (
#define _Imaginary_I ) complex_h (

// X11/X.h, X11/Xlib.h, X11/Xutil.h
#define None ) X11 (
#define Success ) X11 (
#define Status ) X11 (
#define Bool ) X11 (
#define True ) X11 (
#define False ) X11 (
#define Always ) X11 (
#define Complex ) X11 (
#define Convex ) X11 (
#define Nonconvex ) X11 (
#define Above ) X11 (
#define Below ) X11 (
#define Unsorted ) X11 (
#define YSorted ) X11 (
#define KeyPress ) X11 (
#define FocusIn ) X11 (
#define FocusOut ) X11 (
#define Expose ) X11 (
#define Opposite ) X11 (
#define GrayScale ) X11 (
#define DestroyAll ) X11 (
#define CurrentTime ) X11 (
#define NoSymbol ) X11 (
#define CursorShape ) X11 (
#define ControlMask ) X11 (
#define Button1 ) X11 (
#define AnyKey ) X11 (

// <windows.h>
#define near ) windows (
#define far ) windows (
#define small ) windows (
#define hyper ) windows (
#define interface ) windows (
#define pascal ) windows (
#define cdecl ) windows (
#define huge ) windows (
#define IN ) windows (
#define OUT ) windows (
#define OPTIONAL ) windows (
#define NEAR ) windows (
#define FAR ) windows (
#define CONST ) windows (
#define VOID ) windows (
#define TRUE ) windows (
#define FALSE ) windows (
#define ERROR ) windows (
#define NO_ERROR ) windows (
#define DELETE ) windows (
#define STRICT ) windows (
#define ABSOLUTE ) windows (
#define RELATIVE ) windows (
#define IGNORE ) windows (
#define INFINITE ) windows (
#define CALLBACK ) windows (
#define TRANSPARENT ) windows (
#define OPAQUE ) windows (
#define DIFFERENCE ) windows (
#define DOMAIN ) windows (
#define SING ) windows (
#define OVERFLOW ) windows (
#define UNDERFLOW ) windows (
#define GetObject ) windows (
#define SendMessage ) windows (
#define rad1 ) windows (
#define grp1 ) windows (

// <sys/sysmacros.h>, <sys/param.h>, gnu++20, <termios.h>, <math.h>
#define major ) posix (
#define minor ) posix (
#define makedev ) posix (
#undef linux // a compiler's own by -std=gnu++20
#define linux ) posix (
#undef unix // a compiler's own by -std=gnu++20
#define unix ) posix (
#undef i386 // a compiler's own by -std=gnu++20
#define i386 ) posix (
#define howmany ) posix (
#define roundup ) posix (
#define powerof2 ) posix (
#define MIN ) posix (
#define MAX ) posix (
#define B0 ) posix (
#define B50 ) posix (
#define B300 ) posix (
#define B9600 ) posix (
#define ECHO ) posix (
#define ISIG ) posix (
#define CREAD ) posix (
#define CR0 ) posix (
#define NL0 ) posix (
#define TAB0 ) posix (
#define VMIN ) posix (
#define VTIME ) posix (
#define HUGE ) posix (

// Qt without QT_NO_KEYWORDS
#define signals ) qt (
#define slots ) qt (
#define emit ) qt (
#define foreach ) qt (
#define forever ) qt (
