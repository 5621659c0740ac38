// SPDX-License-Identifier: GPL-2.0-only
//! Names of the exceptions of the core and of the STM32G431's interrupts.

/// Name of an exception number; an interrupt that has no name here is called by its number.
#[must_use]
pub fn exception_name(exception: u16) -> String {
    let name = match exception {
        2 => "NonMaskableInt",
        3 => "HardFault",
        4 => "MemoryManagement",
        5 => "BusFault",
        6 => "UsageFault",
        11 => "SVCall",
        14 => "PendSV",
        15 => "SysTick",
        20 => "FLASH",
        22 => "EXTI0",
        23 => "EXTI1",
        24 => "EXTI2",
        25 => "EXTI3",
        26 => "EXTI4",
        34 => "ADC1_2",
        39 => "EXTI9_5",
        40 => "TIM1_BRK_TIM15",
        41 => "TIM1_UP_TIM16",
        42 => "TIM1_TRG_COM_TIM17",
        43 => "TIM1_CC",
        44 => "TIM2",
        45 => "TIM3",
        46 => "TIM4",
        54 => "USART2",
        56 => "EXTI15_10",
        70 => "TIM6_DAC",
        71 => "TIM7",
        107 => "LPUART1",
        116 => "CORDIC",
        117 => "FMAC",
        other => return format!("exception {other}"),
    };
    name.to_owned()
}
