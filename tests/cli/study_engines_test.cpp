// SPDX-License-Identifier: BSD-3-Clause
//
// Studies on other engines, for real: GNU parallel, and a Slurm of one node that the test starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/one_node_slurm.h"
#include "cli/process.h"
#include "cli/small_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// A new folder that everybody may look into, as munge wants it.
class EngineFolder {
public:
    EngineFolder() {
        std::string pattern = (fs::temp_directory_path() / "dttmm-test-XXXXXX").string();
        path_ = ::mkdtemp(pattern.data());
        fs::permissions(path_, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                                   fs::perms::others_read | fs::perms::others_exec);
    }
    ~EngineFolder() {
        std::error_code none;
        fs::remove_all(path_, none);
    }
    EngineFolder(const EngineFolder&) = delete;
    EngineFolder& operator=(const EngineFolder&) = delete;
    const fs::path& path() const { return path_; }
    fs::path operator/(const char* name) const { return path_ / name; }

private:
    fs::path path_;
};

std::vector<std::string> study_words(const std::string& folder, const std::string& engine = "") {
    std::vector<std::string> words = {"study",   "model.toml", "--vary", "mass ~ uniform(1 kg, 3 kg)",
                                      "--cases", "60",         "-o",     folder};
    if (!engine.empty()) words.insert(words.end(), {"--on", engine});
    return words;
}

// Oracle: the bytes of the same study on this machine's cores.
TEST(StudyEngines, GnuParallelGivesTheSameResults) {
    if (::access("/usr/bin/parallel", X_OK) != 0) GTEST_SKIP() << "GNU parallel is not installed";
    const EngineFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    ASSERT_EQ(run_dttmm(folder.path(), study_words("here")).code, 0);
    const Ended ended = run_dttmm(folder.path(), study_words("a 'strange' folder", "parallel"));
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(read_text(folder.path() / "a 'strange' folder/results.csv"), read_text(folder / "here/results.csv"));
}

TEST(StudyEngines, WithoutThemTheCureIsTold) {
    if (::access("/usr/bin/sbatch", X_OK) == 0 && ::access("/usr/bin/parallel", X_OK) == 0) ::setenv("PATH", "/nowhere", 1);
    const EngineFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    const std::string path = ::getenv("PATH");
    for (const auto& [engine, package] : {std::pair("parallel", "parallel"), {"slurm", "slurm-wlm"}}) {
        const Ended ended = run_dttmm(folder.path(), study_words("out", engine));
        EXPECT_EQ(ended.code, 5);
        EXPECT_THAT(ended.err, HasSubstr("is not installed: sudo apt-get install " + std::string(package)));
    }
    ::setenv("PATH", "/usr/local/bin:/usr/bin:/bin", 1);
    EXPECT_EQ(run_dttmm(folder.path(), study_words("out")).code, 0) << "what was asked for goes on here";
}

// Oracle: the bytes of the same study on this machine's cores. The array is cut to what the site allows; a task that is
// cancelled leaves its cases, and only those are submitted again.
TEST(StudyEngines, SlurmWorksOnAJobArray) {
    if (!OneNodeSlurm::is_installed()) GTEST_SKIP() << "slurm-wlm or munge is not installed";
    const EngineFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    const OneNodeSlurm slurm(folder / "slurm", 9);
    ASSERT_TRUE(slurm.is_up()) << OneNodeSlurm::output_of("sinfo; tail -5 " + (folder / "slurm/log").string() + "/*");
    ASSERT_EQ(run_dttmm(folder.path(), study_words("here", "")).code, 0);

    Ended ended = run_dttmm(folder.path(), study_words("out", "slurm:--time=5 --hold"));
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("60 cases in 8 tasks of a job array handed to Slurm"));
    EXPECT_THAT(run_dttmm(folder.path(), {"study", "status", "out"}).out,
                HasSubstr("0 of 60 cases completed, 0 failed, 60 not run"));
    const std::string job = OneNodeSlurm::output_of("squeue -h -o %F | head -1");
    OneNodeSlurm::output_of("scancel " + job.substr(0, job.find('\n')) + "_3");
    OneNodeSlurm::output_of("scontrol release " + job);
    const auto is_idle = [] { return OneNodeSlurm::output_of("squeue -h").empty(); };
    ASSERT_TRUE(wait_until(is_idle));
    const std::string status = run_dttmm(folder.path(), {"study", "status", "out"}).out;
    EXPECT_THAT(status, testing::AnyOf(HasSubstr("52 of 60 cases completed, 0 failed, 8 not run"),
                                       HasSubstr("53 of 60 cases completed, 0 failed, 7 not run")));

    ended = run_dttmm(folder.path(), study_words("out", "slurm"));
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, testing::AnyOf(HasSubstr("8 cases in 8 tasks"), HasSubstr("7 cases in 7 tasks")));
    ASSERT_TRUE(wait_until(is_idle));
    ASSERT_EQ(run_dttmm(folder.path(), {"study", "collect", "out", "-q"}).code, 0);
    EXPECT_EQ(read_text(folder / "out/results.csv"), read_text(folder / "here/results.csv"));
}

}  // namespace
}  // namespace dttmm::host
