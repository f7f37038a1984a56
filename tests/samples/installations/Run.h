#pragma once

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

/// A folder of a test's own, empty at first and gone with it.
class OwnFolder
{
public:
    explicit OwnFolder(const std::string& name) :
        path((std::filesystem::temp_directory_path() /
              ("midair_" + name + "_" + std::to_string(::getpid())))
                 .string())
    {
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~OwnFolder() { std::filesystem::remove_all(path); }
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;

    const std::string path;
};

/// What an installation did, run headless.
struct Visit
{
    Outcome outcome;
    nlohmann::json report;
};

/// Runs midair-NAME without pictures, with its report in \a out.
inline Visit visit(const std::string& name, const std::string& arguments, const OwnFolder& out)
{
    Visit made;
    made.outcome = shell(std::string("'") + MIDAIR_BIN + "/midair-" + name +
                         "' --headless --pictures 0 --out '" + out.path + "' " + arguments);
    std::ifstream file(out.path + "/report.json");
    if (file) made.report = nlohmann::json::parse(file, nullptr, false);
    return made;
}
