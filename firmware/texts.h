// Texts of the tables that only a host shows. A bare-metal board, which has little code memory, leaves them out: 7 kB.
#pragma once

#ifdef THIMBLE_NO_TEXTS
#define THIMBLE_TEXT(text) ""
#else
#define THIMBLE_TEXT(text) text
#endif
