/* linkage.h: C++ calls the functions of a header between LINKAGE_BEGIN and LINKAGE_END by their names in C. */

#ifndef LINKAGE_H
#define LINKAGE_H

#ifdef __cplusplus
#define LINKAGE_BEGIN extern "C" {
#define LINKAGE_END }
#else
#define LINKAGE_BEGIN
#define LINKAGE_END
#endif

#endif
