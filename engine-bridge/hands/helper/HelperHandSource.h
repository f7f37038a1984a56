#pragma once

#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/osc/OscInbox.h"
#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

class HelperProcess;

/// Options of a HelperHandSource.
struct HelperOptions
{
    std::vector<std::string> command; ///< path of the program, and its arguments
    std::string name = "openxr";      ///< prefix of its messages
    double retry_s = 1.0;   ///< > 0; pause before a restart; each pause doubles, up to 30 s
    double patience_s = 10; ///< > 0; a helper silent for this long is ended
};

/// The hands that a helper process tracks and sends as OSC (OscHands.h), in the scene's world, for
/// any requested time. A library that a process can load only once, such as OpenXR's, then runs in
/// another process. The helper lives as long as the source, and is restarted when it ends or stops
/// sending; both are reported.
class HelperHandSource : public HandSource
{
public:
    explicit HelperHandSource(const HelperOptions& options);
    ~HelperHandSource() override; ///< ends the helper
    HelperHandSource(const HelperHandSource&) = delete;
    HelperHandSource& operator=(const HelperHandSource&) = delete;

    bool frameAt(double time_s, HandFrame& frame) override;
    /// Requests predicted hands from the helper.
    bool setHorizon(double ahead_s) override;
    std::string status() const override;

    std::vector<std::string> takeMessages() override { return _inbox.messages(_told); }

    int process() const { return _process; } ///< process id of the helper; 0: none now
    int started() const { return _started; } ///< number of starts

private:
    void run();
    std::string follow(HelperProcess& helper, double& lived_s);
    bool receive(int socket);
    void sendHorizon(int socket, double& sent_s);
    void lose(const std::string& why);

    const HelperOptions _options;
    OscInbox _inbox;
    int _stop; ///< a file descriptor that becomes readable at the end
    std::atomic<int> _process{0};
    std::atomic<int> _started{0};
    std::atomic<double> _horizon_s{0.0};
    std::size_t _told = 0;
    mutable base::Mutex _mutex;
    std::string _condition MIDAIR_GUARDED_BY(_mutex); ///< empty: running
    std::thread _thread;                              ///< last: it uses the other members
};

} // namespace midair::bridge
