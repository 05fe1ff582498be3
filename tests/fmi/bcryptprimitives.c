/* bcryptprimitives.dll for Wine before 9, which lacks it: random bytes from the older function behind the same door.
 * Windows itself has the library since version 7; it is not part of any FMU. */

#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID buffer, ULONG length); /* RtlGenRandom, advapi32 */

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) {
    return SystemFunction036(data, (ULONG)length);
}
