#pragma once

#include <memory>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// A command of midair-display with its options. run() returns the exit status, or -1 if another
/// command was given. Throws base::InputError.
class DisplayCommand
{
public:
    DisplayCommand() = default;
    DisplayCommand(const DisplayCommand&) = delete;
    DisplayCommand& operator=(const DisplayCommand&) = delete;
    virtual ~DisplayCommand() = default;
    /// Returns an ExitCode; EXIT_PROBLEM: the output gives the reason, and no file was written.
    virtual int run() = 0;
};

/// \{ Adds the commands "calibrate" and "check" with their options to \a app.
std::unique_ptr<DisplayCommand> addCalibrate(CLI::App& app);
std::unique_ptr<DisplayCommand> addCheck(CLI::App& app);
/// \}

} // namespace midair::samples
