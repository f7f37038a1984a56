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
    std::vector<std::string> command; ///< file of the program, and its arguments
    std::string name = "openxr";      ///< begins its messages
    double retry_s = 1.0;   ///< > 0; before it is started again; each pause doubles, up to 30 s
    double patience_s = 10; ///< > 0; one that says nothing for so long is ended
};

/// The hands that a helper process sees and sends as OSC (OscHands.h), in the world of the scene,
/// whatever time is asked for: a library that a program can have once, such as OpenXR's, is in
/// another process then. The helper lives as long as the source, and is started again when it has
/// ended or says nothing; both are told.
class HelperHandSource : public HandSource
{
public:
    explicit HelperHandSource(const HelperOptions& options);
    ~HelperHandSource() override; ///< ends the helper
    HelperHandSource(const HelperHandSource&) = delete;
    HelperHandSource& operator=(const HelperHandSource&) = delete;

    bool frameAt(double time_s, HandFrame& frame) override;
    /// The helper is asked for the hands of so much later.
    bool setHorizon(double ahead_s) override;
    std::string status() const override;

    std::vector<std::string> takeMessages() override { return _inbox.messages(_told); }

    int process() const { return _process; } ///< of the helper; 0: none now
    int started() const { return _started; } ///< how often

private:
    void run();
    std::string follow(HelperProcess& helper, double& lived_s);
    bool receive(int socket);
    void sendHorizon(int socket, double& sent_s);
    void lose(const std::string& why);

    const HelperOptions _options;
    OscInbox _inbox;
    int _stop; ///< a file descriptor that gets readable at the end
    std::atomic<int> _process{0};
    std::atomic<int> _started{0};
    std::atomic<double> _horizon_s{0.0};
    std::size_t _told = 0;
    mutable base::Mutex _mutex;
    std::string _condition MIDAIR_GUARDED_BY(_mutex); ///< empty: it runs
    std::thread _thread;                              ///< last: it uses the other members
};

} // namespace midair::bridge
