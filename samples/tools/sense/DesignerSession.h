#pragma once

#include "haptics/sensation/SensationPlayer.h"
#include "samples/tools/sense/DesignerMessages.h"
#include "samples/tools/sense/SenseOutput.h"

#include <Eigen/Core>

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

namespace midair::samples
{

/// What an AdapTics Designer and its device say to each other, without the network: keeps the
/// pattern, its parameters and the start that the Designer sends, plays them on a SenseOutput, and
/// tells the Designer what is played. Times are those of the steady clock, s, and may not descend.
class DesignerSession
{
public:
    /// Largest message: that of a pattern may have each of its characters escaped.
    static constexpr std::size_t kMostBytes = (std::size_t(8) << 20) + (std::size_t(64) << 10);
    /// Largest message but for that of a pattern.
    static constexpr std::size_t kMostOtherBytes = std::size_t(64) << 10;
    static constexpr double kSample_ms = 1.0;        ///< interval of the samples that are told
    static constexpr std::size_t kMostSamples = 100; ///< of an answer; older ones are left out

    /// \a tell receives sentences for the user.
    DesignerSession(SenseOutput& output, std::function<void(const std::string&)> tell);

    /// Follows a message. Returns the answer to send, or an empty text. A message that isn't JSON,
    /// a pattern or a start that can't be read, and whatever the output refuses end playing;
    /// another message with a mistake changes nothing.
    std::string take(const std::string& message, double now_s);
    /// Returns the playback_update with the samples since the last one, or an empty text while
    /// nothing is played. The one of a pattern that has stopped says so, and is the last.
    std::string update(double now_s);
    /// Returns the tracking_data with the output's hand, to be sent with each update, or an empty
    /// text while there is none. That it has gone is told once.
    std::string tracking();
    bool isPlaying() const { return _player != nullptr; }
    /// The Designer has gone: ends playing, and forgets what it has sent.
    void reset();

private:
    using Value = base::JsonValue;
    using Command = void (DesignerSession::*)(const Value& data, double now_s);

    /// What is played, of the steps since its start.
    struct Course
    {
        double start_s = 0.0;
        double begin_ms = 0.0; ///< time in the pattern of the start
        double next = 0.0;     ///< index of the sample that is told next
    };

    static Command commandOf(const std::string& name);
    std::string refuse(const std::string& what, bool ends);
    void setPattern(const Value& data, double now_s);
    void setStart(const Value& data, double now_s);
    void setParameters(const Value& data, double now_s);
    void setTracking(const Value& data, double now_s);
    void setUserParameter(const Value& data, double now_s);
    void setUserParameters(const Value& data, double now_s);
    void setTime(const Value& data, double now_s);
    void setTransform(const Value& data, double now_s);

    void begin(double begin_ms, double now_s);
    void send(double begin_ms);
    void sendParameters(double now_s);
    void place(const Eigen::Matrix4d& transform);
    void end();
    void sampleUntil(double now_s);
    DesignerSample told(const haptics::SensationSample& sample, double time_ms) const;
    void tellProblems(const haptics::SensationSample& sample);
    void tell(const std::string& what);
    void tellOnce(const std::string& what);

    SenseOutput& _output;
    std::function<void(const std::string&)> _tell;
    std::string _json; ///< of the pattern
    std::shared_ptr<const haptics::Sensation> _sensation;
    std::optional<double> _sentFrom_ms; ///< the output has the pattern from this time on
    DesignerParameters _parameters;
    double _time_ms = 0.0;                                    ///< the time that the Designer shows
    Eigen::Matrix4d _transform = Eigen::Matrix4d::Identity(); ///< m
    std::unique_ptr<haptics::SensationPlayer> _player;        ///< null: nothing is played
    Course _course;
    std::deque<DesignerSample> _samples; ///< that the Designer isn't told yet
    bool _owesStop = false;              ///< playing has ended, and the Designer doesn't know it
    bool _showsHand = false;             ///< the Designer
    std::string _lastTold;
    std::set<std::string> _toldOnce;
};

} // namespace midair::samples
