import pytest

pytest.register_assert_rewrite("robots.robot_contract")
