#include "device/boards/BoardKind.h"

namespace midair::device
{

extern const BoardKind kSonicSurface;
extern const BoardKind kUltraino;
extern const BoardKind kOpenMpd;

// A list, since files that register themselves would be left out: a linker drops objects of a
// static library that nothing refers to.
const std::vector<BoardKind>& boardKinds()
{
    static const std::vector<BoardKind> kKinds = {kSonicSurface, kUltraino, kOpenMpd};
    return kKinds;
}

std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& scheme)
{
    for (const BoardKind& kind : boardKinds())
        if (scheme == kind.scheme) return kind.makeCodec();
    return nullptr;
}

} // namespace midair::device
