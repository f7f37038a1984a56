#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace midair::device::autd3
{

/// Why a datagram is not taken.
enum class Refusal : std::uint8_t
{
    MALFORMED,      ///< no answer of the protocol
    FOREIGN,        ///< from an address that no unit of ours has
    STRAY,          ///< answers nothing that was asked, or a second time
    WRONG_ID,       ///< from a unit's address, with another id or no result
    OTHER_PROTOCOL, ///< of another version
    COUNT
};

/// Counts datagrams that are not taken, and logs each kind at most every kLog_s.
///
/// Copies and late answers are how a network is: of strays only the number is kept.
class Refusals
{
public:
    static constexpr double kLog_s = 10;

    explicit Refusals(std::string device) : _device(std::move(device)) {}

    void add(Refusal refusal, const std::string& what, double now_s);
    std::uint64_t count(Refusal refusal) const { return _entries[index(refusal)].count; }
    std::uint64_t total() const; ///< without strays
    /// "2 malformed, 1 foreign"; empty: none but strays.
    std::string text() const;

private:
    /// What one kind has come to.
    struct Entry
    {
        std::uint64_t count = 0;
        std::uint64_t logged = 0; ///< count when it was logged last
        double logged_s = 0;
    };
    static std::size_t index(Refusal refusal) { return static_cast<std::size_t>(refusal); }

    std::string _device;
    std::array<Entry, static_cast<std::size_t>(Refusal::COUNT)> _entries{};
};

} // namespace midair::device::autd3
