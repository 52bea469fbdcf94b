/* version.h - what this program is. */
#ifndef KITH_APP_VERSION_H
#define KITH_APP_VERSION_H
const char *kith_version(void);
#endif
