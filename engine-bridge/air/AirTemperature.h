#pragma once

#include "engine-bridge/air/TemperatureSource.h"
#include "haptics/base/text/MessageLog.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The temperature that fields are solved for: the one that is set, or one that follows a source in
/// small steps, so that a field goes on from the last one and nothing is heard or felt of it.
///
/// What is followed is the median of the last three good readings: a single wrong one does nothing.
/// Without a good reading for kStale_s the last one is kept, as rooms change slowly and a wrong
/// temperature costs accuracy alone; no cap depends on it by more than a percent in 5 K.
class AirTemperature
{
public:
    static constexpr double kStep_K = 0.1;   ///< largest step
    static constexpr double kLeast_K = 0.05; ///< what differs by less is not followed
    static constexpr double kPause_s = 0.2;  ///< between two steps: 0.5 K/s at most
    static constexpr double kStale_s = 60.0; ///< without a good reading

    /// Follows \a file from now on; empty: no source. Goes on as before if it is the same.
    void setSource(const std::string& file);

    const std::string& source() const { return _name; }

    /// Returns the temperature for now, \a now_s on the steady clock, C. \a set_C is what is set:
    /// it holds at once while there is no source, and is where a source's steps begin.
    double at(double now_s, double set_C);

    /// The same for the readings in \a news instead of the source's.
    double follow(const TemperatureSource::News& news, double now_s, double set_C);

    /// What is to be told since the last call; each kind of trouble once until it has ended.
    std::vector<base::Message> takeMessages();

private:
    void listen(const TemperatureSource::News& news, double now_s);
    double median() const;
    void tell(const std::string& what);

    std::unique_ptr<TemperatureSource> _source;
    std::string _name;             // of the source, for messages
    std::array<double, 3> _last{}; // newest good readings
    int _readings = 0;             // of _last
    double _now_C = 0.0;           // what is solved for
    bool _follows = false;         // _now_C is known
    double _heard_s = 0.0;         // of the last good reading, or of the source's begin
    double _bad_s = 0.0;           // of the last bad one
    double _stepped_s = 0.0;
    bool _hasBegun = false;
    bool _badTold = false, _staleTold = false, _closedTold = false;
    std::vector<base::Message> _messages;
};

} // namespace midair::bridge
