#include "engine-bridge/hands/osc/OscInbox.h"
#include "haptics/base/InputError.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <sys/mman.h>
#include <unistd.h>

using namespace midair;

namespace
{

/// Room whose last byte is before a page that must not be read: Debian's oscpack is compiled
/// without the sanitizers, so that they don't see what it reads.
class Edge
{
public:
    Edge()
    {
        const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
        _size = (bridge::kMostOscBytes + 2 * page) / page * page;
        void* room = ::mmap(nullptr, _size + page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        require(room != MAP_FAILED && ::mprotect(room, _size, PROT_READ | PROT_WRITE) == 0,
                "there is memory");
        _room = static_cast<char*>(room);
    }

    const char* put(const std::uint8_t* data, std::size_t size) const
    {
        if (size > 0) std::memcpy(_room + _size - size, data, size);
        return _room + _size - size;
    }

private:
    char* _room = nullptr;
    std::size_t _size = 0;
};

} // namespace

void fuzzOsc(const std::uint8_t* data, std::size_t size)
{
    static const Edge edge;
    size = std::min(size, bridge::kMostOscBytes);
    const char* bytes = edge.put(data, size);
    try
    {
        const bridge::OscContent content = bridge::decodeOsc(bytes, size);
        for (const auto& timed : content.hands)
        {
            require(timed.hand.id == 0 || timed.hand.id == 1, "a hand is left or right");
            require(std::isfinite(timed.time_s) && timed.hand.age_s >= 0.0, "times are finite");
            for (const bridge::HandJoint& joint : timed.hand.joints)
            {
                require(joint.position.allFinite() && joint.orientation.coeffs().allFinite() &&
                            std::isfinite(joint.radius_m),
                        "joints are finite, valid or not");
                require(!joint.positionValid ||
                            (joint.position.norm() <= bridge::kFarthestJoint_m &&
                             joint.radius_m > 0.0 && joint.radius_m <= bridge::kThickestJoint_m),
                        "valid joints are near and thin");
            }
        }
        for (const std::string& text : content.texts)
            require(
                std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F; }),
                "texts are printable");
    }
    catch (const base::InputError& error)
    {
        require(*error.what() != '\0', "an error says something");
    }
    bridge::OscInbox inbox("fuzz");
    inbox.take(bytes, size, "a", 1.0);
    bridge::HandFrame frame;
    inbox.latest(1.05, frame);
    require(frame.hands.size() <= 2, "there are two hands at most");
    require(!inbox.latest(1.1001, frame), "hands are lost");
}
