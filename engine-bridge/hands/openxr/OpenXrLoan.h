#pragma once

#include "engine-bridge/hands/openxr/OpenXrLending.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include <cstdint>
#include <memory>
#include <string>

namespace midair::bridge
{

/// Lends a session of the program to all trackers. While it exists, trackers have no connection of
/// their own, so that the program can have the only one. For one thread.
class OpenXrLoan
{
public:
    /// Waits for the end of a tracker's connection. Throws base::InputError.
    OpenXrLoan();
    ~OpenXrLoan();
    OpenXrLoan(const OpenXrLoan&) = delete;
    OpenXrLoan& operator=(const OpenXrLoan&) = delete;

    /// Locates hands and head in that session from now on. Throws base::InputError.
    void lend(const OpenXrHandles& handles, OpenXrSpace space);
    /// On return, that session is no longer used.
    void withdraw();
    bool isLent() const { return _session != nullptr; }
    std::string runtime() const; ///< name and version; empty: nothing is lent

    /// Sets the runtime's display \a time of the present frame: hands are located for it, too.
    void setDisplayTime(std::int64_t time);
    void setRunning(bool isRunning);
    void tellRecentred();

private:
    std::shared_ptr<OpenXrSession> _session;
};

} // namespace midair::bridge
