#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

/// A folder that goes with this.
struct TemporaryFolder
{
    std::filesystem::path path;
    TemporaryFolder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "osgmidair-XXXXXX").string();
        path = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    std::string write(const std::string& name, const std::string& text) const
    {
        std::ofstream(path / name) << text;
        return (path / name).string();
    }
};

/// A program of OSG's that loads the kit. A sanitizer's runtime has to be there before it; what OSG
/// leaves unfreed isn't told.
inline std::string stock(const std::string& program)
{
    const std::string runtime = MIDAIR_SANITIZER_RUNTIME;
    if (runtime.empty()) return program;
    return "env ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD=" + runtime + " " + program;
}

/// Frames for osgviewer to run: until there is a field, which takes longer under a sanitizer.
inline std::string frames()
{
    return std::string(MIDAIR_SANITIZER_RUNTIME).empty() ? "300" : "5000";
}

/// How many of them a second there are at most: so many take two seconds, however fast nothing much
/// is drawn.
inline std::string frameRate()
{
    return std::string(MIDAIR_SANITIZER_RUNTIME).empty() ? "150" : "2500";
}

/// Runs a command with the kit in OSG's path; its output, and whether it ended well.
inline std::string run(const std::string& command, bool& ok)
{
    const std::string full =
        "OSG_LIBRARY_PATH=" MIDAIR_LIBRARY_FOLDER " OSG_RUN_MAX_FRAME_RATE=" + frameRate() + " " +
        command + " 2>&1";
    std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(full.c_str(), "r"), pclose);
    std::string output;
    char buffer[4096];
    while (pipe && std::fgets(buffer, sizeof buffer, pipe.get()))
        output += buffer;
    ok = pipe && pclose(pipe.release()) == 0;
    return output;
}

inline bool installed(const char* program)
{
    return std::system((std::string("command -v ") + program + " >/dev/null").c_str()) == 0;
}

inline std::string contents(const std::filesystem::path& file)
{
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}
