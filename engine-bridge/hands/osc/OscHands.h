#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// \{ Addresses of what is sent; samples/guides/HANDS.md has their arguments.
constexpr const char* kOscHand = "/midair/hand";
constexpr const char* kOscHead = "/midair/head";
constexpr const char* kOscText = "/midair/text";
constexpr const char* kOscHorizon = "/midair/horizon";
/// \}

/// A datagram that is longer is none of hands: two take 2,600 bytes.
constexpr std::size_t kMostOscBytes = 8192;
constexpr double kOldestOscHand_s = 10.0; ///< the largest age that a sender may tell, of heads too
constexpr double kFarthestOscHorizon_s = 1.0; ///< how far ahead hands may be asked for

/// Throws base::InputError in a build without OSC. All that sends or receives asks first.
void requireOsc();

/// What one datagram says.
struct OscContent
{
    /// A hand and the sender's time of it.
    struct Timed
    {
        double time_s = 0.0; ///< the sender's clock, whose zero is its own
        Hand hand;           ///< age_s: when it was sent
    };
    std::vector<Timed> hands;
    /// The newest head; time_s: the sender's clock, NaN if it tells none; age_s: when it was sent.
    std::optional<Head> head;
    std::vector<std::string> texts; ///< what the sender has to tell the user
    double horizon_s = -1.0;        ///< >= 0: the receiver asks for hands so much later; else: not
    std::size_t jointsLeftOut = 0;  ///< that are called valid and can't be, and such heads
    std::string firstLeftOut;       ///< what is wrong with the first of them
    std::string unknown;            ///< the first address that isn't known; empty: none
    std::size_t unknownCount = 0;
};

/// Reads a datagram of \a size bytes: a message, or a bundle of them, also one in another. Throws
/// base::InputError, which says what is wrong, for one that has any mistake: a datagram counts as a
/// whole or not at all. Reads no byte outside of it, and keeps none.
OscContent decodeOsc(const char* data, std::size_t size);

/// Datagrams as they are sent: their bytes are valid until the next call.
class OscWriter
{
public:
    /// A bundle with a message for each of \a hands whose id is 0 or 1, others are left out; an
    /// empty one, which says that the sender is there, if there are none. \a time_s: the sender's
    /// clock, which must rise.
    std::size_t hands(const std::vector<Hand>& hands, double time_s);
    /// A head, at head.time_s of the sender's clock, which must rise.
    std::size_t head(const Head& head);
    std::size_t text(const std::string& text); ///< cut after 1000 bytes
    std::size_t horizon(double ahead_s);       ///< >= 0

    const char* data() const { return _bytes.data(); }

private:
    std::array<char, kMostOscBytes> _bytes{};
};

} // namespace midair::bridge
